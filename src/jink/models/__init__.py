"""What may move, what is measured and how uncertain both are: data and equations, no input or output."""
