"""Static poses that lean on objects: rigid contact without friction, on a smooth tube about the backbone."""
