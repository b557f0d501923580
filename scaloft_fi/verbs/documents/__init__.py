"""The YAML documents of a study, each as a JSON Schema that editors and programs use."""
