"""Life cycles: for each thing its states, the allowed transitions, and the only code that assigns its state."""
