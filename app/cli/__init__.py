"""The command line, `macta`."""


def main() -> None:
    """The entry point."""
    from app.cli.main import app

    app()


__all__ = ["main"]
