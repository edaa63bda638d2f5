"""Costs of the operator's page, in a headless Chromium with the real service."""
