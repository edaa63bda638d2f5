"""What the operator's page costs, in a headless Chromium before the real service."""
