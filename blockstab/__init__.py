"""Understand one RGB-D image as things that stand."""
