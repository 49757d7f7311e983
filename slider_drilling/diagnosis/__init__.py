"""The drill string as a model of the gap engine, and the result of its diagnosis.

`diagnose` checks the logs, builds the model, runs the engine and fills one `result.Diagnosis`, from which `to_json`,
`page` and `sentences` write.
"""
