"""Costs: by which factor it takes longer to walk through each cell of a map."""
