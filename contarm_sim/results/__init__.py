"""What a simulation found, and its comparison with the closed forms. Opens without MuJoCo."""
