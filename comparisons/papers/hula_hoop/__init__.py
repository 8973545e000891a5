"""The paper on hula_hoop: its figures, and what it prints and claims."""
