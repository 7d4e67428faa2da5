"""Generated modules as callables, loaded through a cache."""

from rodgen.loading.build import (
    build,
    build_fastest,
    build_or_explain,
    companions,
    is_derived,
    sources,
)
from rodgen.loading.generated_module import load_files, load_module, load_text
from rodgen.native.library import BuildError
