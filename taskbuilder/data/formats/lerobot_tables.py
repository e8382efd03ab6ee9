"""The Parquet files of LeRobot, with the metadata that `datasets` and pandas look for."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskbuilder.extras import extra_needed
from taskbuilder.files import write_whole

LANGUAGE = "language"
"""What LeRobot calls the type of a column of texts with their times."""

LANGUAGE_FIELDS = {
    "role": "string",
    "content": "string",
    "style": "string",
    "timestamp": "float32",
    "camera": "string",
}
"""Types of what a row of language holds, besides calls of tools, of which there are none."""


def require_parquet() -> None:
    """Check that Parquet can be written here.

    Raises:
        UsageError: PyArrow is not installed.
    """
    with extra_needed("data", "the format lerobot"):
        import pyarrow.parquet  # noqa: F401  # only to see whether it is installed


def frame_table(features: Mapping[str, Any], columns: Mapping[str, Any]) -> Any:
    """The table of the frames of an episode.

    Args:
        features: The features of the data set, without videos.
        columns: By feature: (frames,) or (frames, numbers), a list of PNG files, or of the rows of
            language of each frame.
    """
    import pyarrow as pa

    arrays = [_column(feature, columns[name]) for name, feature in features.items()]
    fields = [pa.field(n, array.type) for n, array in zip(features, arrays, strict=True)]
    metadata = {"info": {"features": {n: _hugging_face(f) for n, f in features.items()}}}
    schema = pa.schema(fields, metadata={"huggingface": json.dumps(metadata)})
    return pa.table(arrays, schema=schema)


def _column(feature: Mapping[str, Any], values: Any) -> Any:
    import pyarrow as pa

    if feature["dtype"] == "image":
        rows = [{"bytes": png, "path": None} for png in values]
        return pa.array(rows, type=pa.struct([("bytes", pa.binary()), ("path", pa.string())]))
    if feature["dtype"] == LANGUAGE:
        return _same_rows(values)
    kind = pa.from_numpy_dtype(np.dtype(feature["dtype"]))
    array: NDArray[Any] = np.asarray(values, dtype=feature["dtype"])
    flat = pa.array(array.reshape(-1), type=kind)
    (size,) = feature["shape"]
    return flat if array.ndim == 1 else pa.FixedSizeListArray.from_arrays(flat, size)


def _same_rows(frames: Sequence[Sequence[Mapping[str, Any]]]) -> Any:
    """The rows of language of an episode, the same in every frame."""
    import pyarrow as pa

    kinds = {"float32": pa.float32(), "string": pa.string()}
    fields = [pa.field(name, kinds[dtype]) for name, dtype in LANGUAGE_FIELDS.items()]
    fields.append(pa.field("tool_calls", pa.list_(pa.string())))
    rows = pa.array(frames[:1], type=pa.list_(pa.struct(fields)))
    return rows.take(pa.array(np.zeros(len(frames), dtype=np.int64)))


def _hugging_face(feature: Mapping[str, Any]) -> dict[str, Any]:
    """A feature as the library `datasets` describes it."""
    if feature["dtype"] == "image":
        return {"_type": "Image"}
    if feature["dtype"] == LANGUAGE:
        texts = {"_type": "List", "feature": {"dtype": "string", "_type": "Value"}}
        fields = {n: {"dtype": d, "_type": "Value"} for n, d in LANGUAGE_FIELDS.items()}
        return {"_type": "List", "feature": {**fields, "tool_calls": texts}}
    value = {"dtype": feature["dtype"], "_type": "Value"}
    if feature["shape"] == [1]:
        return value
    return {"feature": value, "length": feature["shape"][0], "_type": "List"}


def write_table(path: Path, tables: Sequence[Any]) -> None:
    """Write tables of one schema to a file, one after the other.

    Raises:
        OSError: It cannot be written.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    path.parent.mkdir(parents=True, exist_ok=True)
    buffer = pa.BufferOutputStream()
    pq.write_table(pa.concat_tables(tables), buffer, compression="snappy")
    write_whole(path, buffer.getvalue().to_pybytes())


def episode_table(rows: Sequence[Mapping[str, Any]]) -> Any:
    """The table of the episodes, a row each."""
    import pyarrow as pa

    return pa.table({name: pa.array([_plain(row[name]) for row in rows]) for name in rows[0]})


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value


def indexed_table(texts: Sequence[str], index: str, column: str) -> Any:
    """A table that pandas reads with texts as its index, and their numbers as its column.

    Args:
        texts: The texts, in the order of their numbers.
        index: Name of the index.
        column: Name of the column.
    """
    import pyarrow as pa

    def column_info(name: str, kind: str, numpy: str) -> dict[str, Any]:
        return {
            "name": name,
            "field_name": name,
            "pandas_type": kind,
            "numpy_type": numpy,
            "metadata": None,
        }

    pandas = {
        "index_columns": [index],
        "column_indexes": [told_columns()],
        "columns": [column_info(column, "int64", "int64"), column_info(index, "unicode", "object")],
        "creator": {"library": "pyarrow", "version": pa.__version__},
        "pandas_version": "2.2.0",
    }
    fields = [pa.field(column, pa.int64()), pa.field(index, pa.string())]
    schema = pa.schema(fields, metadata={"pandas": json.dumps(pandas)})
    return pa.table([pa.array(range(len(texts)), pa.int64()), pa.array(texts)], schema=schema)


def told_columns() -> dict[str, Any]:
    """What pandas says of the names of columns."""
    return {
        "name": None,
        "field_name": None,
        "pandas_type": "unicode",
        "numpy_type": "object",
        "metadata": {"encoding": "UTF-8"},
    }
