"""What a job leaves on disk and on the terminal."""
