"""Replays of recordings in pictures and words: what `contarm replay` leaves."""
