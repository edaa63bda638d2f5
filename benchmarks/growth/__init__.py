"""How the costs of requests grow with the record."""
