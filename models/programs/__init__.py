"""Command-line programs: training and evaluation."""
