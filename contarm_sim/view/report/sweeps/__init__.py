"""A sweep in pictures and on a page: heat maps, marginals, sensitivity, failures, and the validity chart."""
