"""Legs: the parts of fragments that agents carry out without interruption, and the ways between them."""
