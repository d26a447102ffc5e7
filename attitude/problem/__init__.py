"""What effects, orbits and solvers share: the initial state, torques and their bounds."""
