"""What arms do with what they touch, each as an arm (.toml), a path (.csv) and checks: grasp, reach around, lean."""
