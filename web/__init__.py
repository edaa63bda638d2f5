"""The operator's page: a static console and the viser view of the world. A client of the public API."""
