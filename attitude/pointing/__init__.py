"""Where the axes of a body point: angles, directions, spin, points on the ground; and columns of these."""
