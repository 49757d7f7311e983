"""Tables of rigs' recorders into logs: text, LAS, workbooks, Parquet, WITSML and WITS; a mapping file is optional."""

from slider_drilling.table_import.read_table import ImportedTable, import_table, read_table

__all__ = ["ImportedTable", "import_table", "read_table"]
