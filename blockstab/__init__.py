"""Understand one RGB-D image as things that stand."""

__version__ = "0.1.0"
