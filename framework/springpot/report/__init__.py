"""Reports: numbers, tables, figures and pages made from results."""
