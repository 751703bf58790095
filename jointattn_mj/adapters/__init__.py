"""The suite behind the interfaces of other packages; none is imported before it is used."""
