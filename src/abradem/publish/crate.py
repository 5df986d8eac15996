"""The RO-Crate of the run: its input, software and results, with hashes.

RO-Crate 1.1 (https://w3id.org/ro/crate/1.1) and its profile for runs of a program, Process Run
Crate 0.5 (https://w3id.org/ro/wfrun/process/0.5).
"""

from __future__ import annotations

from abradem.publish.description import LICENCE, LICENCE_NAME, LICENCE_URL, Description, File

PROFILE = "https://w3id.org/ro/wfrun/process/0.5"
SHA256 = "https://w3id.org/ro/terms/workflow-run#sha256"
PYTHON = "https://www.python.org/"
INPUT = "config.yaml"
ABOUT = ("README.md", "croissant.json")
"""Files that describe the results and were not made by the run."""


def crate(description: Description) -> dict:
    """The RO-Crate descriptor, the content of ro-crate-metadata.json."""
    versions = dict(description.versions["versions"])
    ours = versions.pop("abradem")
    made = [f for f in description.files if f.name not in (INPUT, *ABOUT)]
    packages = [
        {
            "@id": address,
            "@type": "SoftwareApplication",
            "name": name,
            "url": address,
            "softwareVersion": version,
        }
        for name, version in sorted(versions.items())
        for address in [PYTHON if name == "python" else f"https://pypi.org/project/{name}/"]
    ]
    creators = [
        {"@id": f"#creator-{number}", "@type": "Person", "name": name}
        for number, name in enumerate(description.creators, start=1)
    ]
    root = {
        "@id": "./",
        "@type": "Dataset",
        "name": description.title,
        "description": description.abstract,
        "version": description.version,
        "datePublished": description.date,
        "license": {"@id": LICENCE_URL},
        "author": _ids(creators),
        "citation": description.citation,
        "conformsTo": {"@id": PROFILE},
        "mentions": {"@id": "#run"},
        "hasPart": [{"@id": file.name} for file in description.files],
        **({"identifier": description.url, "url": description.url} if description.url else {}),
    }
    run = {
        "@id": "#run",
        "@type": "CreateAction",
        "name": f"Run of the study {description.study}",
        "description": (
            f"snakemake with config.yaml of this crate, seed {description.versions['seed']}; "
            f"{_source(description)}versions.json contains a hash of the code of every step and "
            "all packages of the environment"
        ),
        "instrument": {"@id": "#abradem"},
        "agent": {"@id": creators[0]["@id"]},
        "object": {"@id": INPUT},
        "result": [{"@id": file.name} for file in made],
        "actionStatus": "http://schema.org/CompletedActionStatus",
    }
    software = {
        "@id": "#abradem",
        "@type": "SoftwareApplication",
        "name": "abradem",
        "description": "From ranges of material and geometry to a wear data set and wear models",
        "softwareVersion": ours,
        "softwareRequirements": _ids(packages),
    }
    return {
        # The context of RO-Crate 1.1 does not define a hash, the profile does.
        "@context": ["https://w3id.org/ro/crate/1.1/context", {"sha256": SHA256}],
        "@graph": [
            {
                "@id": "ro-crate-metadata.json",
                "@type": "CreativeWork",
                "conformsTo": {"@id": "https://w3id.org/ro/crate/1.1"},
                "about": {"@id": "./"},
            },
            root,
            {
                "@id": LICENCE_URL,
                "@type": "CreativeWork",
                "name": LICENCE_NAME,
                "identifier": LICENCE,
                "url": LICENCE_URL,
            },
            {
                "@id": PROFILE,
                "@type": "CreativeWork",
                "name": "Process Run Crate",
                "version": "0.5",
            },
            *creators,
            run,
            software,
            *packages,
            *map(_file, description.files),
        ],
    }


def _source(description: Description) -> str:
    """Commit of the code, if it came from a repository."""
    source = description.versions.get("source")
    if not source:
        return ""
    return f"code of commit {source['commit']}{' with changes' if source['changed'] else ''}; "


def _ids(entities: list[dict]) -> list[dict] | dict:
    """References to entities; a single reference without a list, as the format recommends."""
    found = [{"@id": entity["@id"]} for entity in entities]
    return found[0] if len(found) == 1 else found


def _file(file: File) -> dict:
    return {
        "@id": file.name,
        "@type": "File",
        "name": file.name,
        "description": file.words,
        "encodingFormat": file.media_type,
        "contentSize": str(file.size),
        "sha256": file.sha256,
    }
