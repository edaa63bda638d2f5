"""The command line, `macta`."""

from robots.kernels import install


def main() -> None:
    """The entry point."""
    install()
    from app.cli.main import app  # after `install`, which must come before the compiled modules are imported

    app()


__all__ = ["main"]
