"""What serves the course: the command line, the environment, the book, the labs."""
