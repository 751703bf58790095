"""The suite behind the interfaces of other packages, none of which is imported before it is used."""
