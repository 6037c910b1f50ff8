"""Weights of the cues of an edge."""
