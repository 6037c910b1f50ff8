"""Stages of merging (Silberman et al. 2012)."""
