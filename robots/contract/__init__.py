"""What every robot needs to keep the contract with the service: the mailbox, known scripts, persistent memory."""
