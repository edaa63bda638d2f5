"""Checks a robot against the contract: plays the service for it, and says which rules it keeps (docs/robots.md)."""
