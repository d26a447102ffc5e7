"""What accuracy costs in time: methods measured side by side against a truth that none of them supplied."""
