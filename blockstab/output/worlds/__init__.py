"""Arrangements of boxes as other programs read them: simulators, robots' planners, viewers of meshes."""
