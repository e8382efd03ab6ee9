"""Reports of validations for machines and for people: JUnit, GitHub, and a page with pictures."""
