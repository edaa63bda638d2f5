"""The command line: `macta serve | demo | plan | world`."""

from app.cli.main import main

__all__ = ["main"]
