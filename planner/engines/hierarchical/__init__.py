"""The hierarchical engine (MACTA §6): fragments found from the knowledge base, composed by scheduling."""
