"""The command line: `macta serve | demo | plan | world`."""

from robots.kernels import install


def main() -> None:
    """The entry point."""
    install()
    from app.cli.main import app  # here: what it imports is compiled

    app()


__all__ = ["main"]
