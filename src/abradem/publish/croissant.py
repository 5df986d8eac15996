"""The Croissant 1.0 descriptor: files, tables and columns, for machine-learning data loaders.

Format: http://mlcommons.org/croissant/1.0.
"""

from __future__ import annotations

from abradem.publish.description import LICENCE_URL, PARTITIONED, Description, File

CONTEXT = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "citeAs": "cr:citeAs",
    "column": "cr:column",
    "conformsTo": "dct:conformsTo",
    "cr": "http://mlcommons.org/croissant/",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "dct": "http://purl.org/dc/terms/",
    "equivalentProperty": "cr:equivalentProperty",
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "extract": "cr:extract",
    "field": "cr:field",
    "fileObject": "cr:fileObject",
    "fileProperty": "cr:fileProperty",
    "fileSet": "cr:fileSet",
    "format": "cr:format",
    "includes": "cr:includes",
    "isLiveDataset": "cr:isLiveDataset",
    "jsonPath": "cr:jsonPath",
    "key": "cr:key",
    "md5": "cr:md5",
    "parentField": "cr:parentField",
    "path": "cr:path",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "recordSet": "cr:recordSet",
    "references": "cr:references",
    "regex": "cr:regex",
    "repeated": "cr:repeated",
    "replace": "cr:replace",
    "samplingRate": "cr:samplingRate",
    "sc": "https://schema.org/",
    "separator": "cr:separator",
    "source": "cr:source",
    "subField": "cr:subField",
    "transform": "cr:transform",
}
"""The JSON-LD context prescribed by the specification."""

TABLES = ("dataset.parquet", "cases.parquet", "failures.parquet")
"""Files described column by column, in addition to one part of each partitioned table."""

_TYPES = {
    "double": "sc:Float",
    "int64": "sc:Integer",
    "int32": "sc:Integer",
    "bool": "sc:Boolean",
    "string": "sc:Text",
}


def croissant(description: Description) -> dict:
    """The Croissant descriptor, the content of croissant.json."""
    tables = [file for file in description.files if file.name in TABLES]
    parts = {file.folder: file for file in description.files if file.folder in PARTITIONED}
    return {
        "@context": CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": f"abradem-{description.study}",
        "alternateName": description.title,
        "description": description.abstract,
        "version": description.version,
        "datePublished": description.date,
        "license": LICENCE_URL,
        "citeAs": description.bibtex,
        "creator": [{"@type": "sc:Person", "name": name} for name in description.creators],
        **({"url": description.url} if description.url else {}),
        "keywords": [
            "wear", "abrasion", "Archard", "discrete element method", "particle impact",
            "surrogate model",
        ],
        "isLiveDataset": False,
        "distribution": [
            *(_file_object(file) for file in tables),
            *(_file_set(folder) for folder in parts),
        ],
        "recordSet": [
            *(
                _record_set(file.name.partition(".")[0], file, "fileObject", file.name)
                for file in tables
            ),
            *(
                _record_set(f"{folder}_by_block", file, "fileSet", f"{folder}-parts")
                for folder, file in parts.items()
            ),
        ],
    }  # fmt: skip


def _file_object(file: File) -> dict:
    return {
        "@type": "cr:FileObject",
        "@id": file.name,
        "name": file.name,
        "description": file.words,
        "contentUrl": file.name,
        "contentSize": f"{file.size} B",
        "encodingFormat": file.media_type,
        "sha256": file.sha256,
    }


def _file_set(folder: str) -> dict:
    return {
        "@type": "cr:FileSet",
        "@id": f"{folder}-parts",
        "name": f"{folder}-parts",
        "description": f"{PARTITIONED[folder]}; one folder per block: block=0, block=1 ...",
        "encodingFormat": "application/x-parquet",
        "includes": f"{folder}/*/*.parquet",
    }


def _record_set(name: str, file: File, kind: str, source: str) -> dict:
    columns = {column[0] for column in file.columns}
    one_row = {"time", "facet_x"}.isdisjoint(columns)
    return {
        "@type": "cr:RecordSet",
        "@id": name,
        "name": name,
        "description": file.words,
        **({"key": {"@id": f"{name}/case_id"}} if one_row else {}),
        "field": [
            {
                "@type": "cr:Field",
                "@id": f"{name}/{column}",
                "name": column,
                "description": meaning if unit == "1" else f"{meaning}, in {unit}",
                "dataType": _TYPES[dtype],
                "source": {kind: {"@id": source}, "extract": {"column": column}},
            }
            for column, dtype, unit, meaning in file.columns
        ],
    }
