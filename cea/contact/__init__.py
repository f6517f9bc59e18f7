"""From points to operators: interfaces, formulations, laws, and the matrices they make."""
