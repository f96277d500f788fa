"""Tiles: the rectangles in which a matrix of distances is computed and written."""

from typing import NamedTuple


class Tile(NamedTuple):
    """Rows top:bottom and columns left:right of a matrix."""

    top: int
    bottom: int
    left: int
    right: int

    @property
    def slices(self) -> tuple[slice, slice]:
        return slice(self.top, self.bottom), slice(self.left, self.right)

    @property
    def mirrored(self) -> "Tile":
        return Tile(self.left, self.right, self.top, self.bottom)

    @property
    def shape(self) -> tuple[int, int]:
        return self.bottom - self.top, self.right - self.left


class Tiling(NamedTuple):
    """A matrix in square tiles; where it is symmetric, those on the diagonal and above it stand for all."""

    shape: tuple[int, int]
    edge: int
    symmetric: bool

    def tiles(self) -> list[Tile]:
        """Return the tiles to compute, row by row."""
        n_rows, n_columns = self.shape
        return [
            Tile(top, min(top + self.edge, n_rows), left, min(left + self.edge, n_columns))
            for top in range(0, n_rows, self.edge)
            for left in range(top if self.symmetric else 0, n_columns, self.edge)
        ]

    def mirror_of(self, tile: Tile) -> Tile | None:
        """Return the tile that holds the same distances transposed, None where there is no other one."""
        return tile.mirrored if self.symmetric and tile.top != tile.left else None
