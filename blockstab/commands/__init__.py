"""What the commands of the command line do. Everything heavy is imported here, not by their options."""
