"""The tests of the 50-digit oracle, and the closed form as it was published."""
