"""What is run: training and evaluation."""
