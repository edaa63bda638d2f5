"""What the service costs: its start, its idle hours and its busy ones, beside the targets."""
