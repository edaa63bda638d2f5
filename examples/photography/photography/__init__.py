"""Robots take pictures of places: a domain pack with code of its own."""
