"""What is drawn and claimed: a folder for each paper, and the lessons between."""
