"""What happens to bodies: events, contact, translation."""
