"""What looks after the project and is no part of the package: run by command, from the checkout."""
