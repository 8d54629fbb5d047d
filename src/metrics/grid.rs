//! Tiles of an image, and the cells in them.

/// The smallest and the largest side of a tile, in pixels.
const TILE: (usize, usize) = (4, 16);
/// Cells along each side of a tile.
pub(super) const CELLS: usize = 4;

/// Tiles of nearly equal size that cover the image, of [`CELLS`] × [`CELLS`] cells each.
pub(super) struct Grid {
    pub width: usize,
    pub height: usize,
    pub columns: usize,
    pub rows: usize,
}

impl Grid {
    /// 64 tiles if their sides are 4 to 16 pixels long; else more or fewer tiles.
    pub fn new(width: usize, height: usize) -> Grid {
        let side = ((width * height) as f64).sqrt() / 8.0;
        let side = (side as usize).clamp(TILE.0, TILE.1);
        Grid { width, height, columns: (width / side).max(1), rows: (height / side).max(1) }
    }

    pub fn tiles(&self) -> usize {
        self.columns * self.rows
    }

    /// The tile of a pixel along an axis of `length` pixels, and the cell in the tile.
    pub fn part(at: usize, length: usize, tiles: usize) -> (usize, usize) {
        let cell = at * tiles * CELLS / length;
        (cell / CELLS, cell % CELLS)
    }

    /// The tile of a pixel.
    pub fn tile_of(&self, pixel: usize) -> usize {
        let (column, _) = Grid::part(pixel % self.width, self.width, self.columns);
        let (row, _) = Grid::part(pixel / self.width, self.height, self.rows);
        row * self.columns + column
    }

    /// Left, top, width and height of a tile.
    pub fn rectangle(&self, tile: usize) -> [usize; 4] {
        let edge = |at: usize, length: usize, tiles: usize| (at * length).div_ceil(tiles);
        let (column, row) = (tile % self.columns, tile / self.columns);
        let (left, top) = (edge(column, self.width, self.columns), edge(row, self.height, self.rows));
        let (right, bottom) = (edge(column + 1, self.width, self.columns), edge(row + 1, self.height, self.rows));
        [left, top, right - left, bottom - top]
    }

    /// A tile and those around it.
    pub fn around(&self, tile: usize) -> impl Iterator<Item = usize> + '_ {
        let (column, row) = (tile % self.columns, tile / self.columns);
        let near = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
        near(row, self.rows)
            .flat_map(move |row| near(column, self.columns).map(move |column| row * self.columns + column))
    }
}
