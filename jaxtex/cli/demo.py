"""`jaxtex demo`: the whole way on a photograph that comes along."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro


@dataclass(frozen=True, kw_only=True)
class Demo:
    """Do the whole way on a photograph of a brick wall, seen at an angle, that comes with scikit-image.

    Writes the photograph, all that 'jaxtex fit tiling' writes, and in the folder 'seamless' maps of twice the
    resolution that repeat without a seam.

    Example: jaxtex demo -o demo
    """

    output: Annotated[Path, tyro.conf.arg(aliases=["-o"], metavar="FOLDER")] = Path("demo")
    """The folder for the results; it is made if there is none."""

    def run(self) -> int:
        from skimage import data

        from jaxtex.cli.fit import Tiling
        from jaxtex.cli.results import results_folder
        from jaxtex.core.colour import srgb_to_linear
        from jaxtex.io.images import write_image

        with results_folder(self.output) as folder:
            photo = folder / "photo.png"
            write_image(photo, srgb_to_linear(data.brick() / 255))
            print(f"jaxtex fit tiling {photo} -o {folder}")
            status = Tiling(photo=photo, output=folder).run()
            if not status:
                self._render(folder)
                print(f"Open {folder / 'report.html'}")
            return status

    def _render(self, folder: Path) -> None:
        from jaxtex.cli.render import Render
        from jaxtex.material.appearance import appearance_of
        from jaxtex.material.sheet import lay_photographed_sheet
        from jaxtex.models.files import load_model

        model = folder / "model.json"
        file = load_model(model)
        sheet = lay_photographed_sheet(file, seamless=True, pattern=appearance_of(file).pattern)
        width, height = (2 * side for side in sheet.natural_size)
        print(f"jaxtex render {model} -o {folder / 'seamless'} --size {width}x{height} --seamless")
        Render(model=model, output=folder / "seamless", size=f"{width}x{height}", seamless=True).run()
