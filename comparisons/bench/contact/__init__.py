"""What ``cea bench contact`` measures: search and assembly of a contact beside evaluating bases."""
