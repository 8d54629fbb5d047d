//@ use bind/kept_shares
//@ use lib/microfacet
// The share of light that comes back from a white metal by single scattering: a table, interpolated.

// As src/material/microfacets.rs has them.
const ROWS_OF_SHARES: u32 = 32u;
const COLUMNS_OF_SHARES: u32 = 32u;

fn kept_share(cosine: f32, roughness: f32) -> f32 {
    let rough = max(roughness, LEAST_ROUGHNESS);
    let alpha = rough * rough;
    let x = cosine * (1.0 + alpha) / (cosine + alpha) * f32(COLUMNS_OF_SHARES - 1u);
    let y = rough * f32(ROWS_OF_SHARES - 1u);
    let column = min(u32(x), COLUMNS_OF_SHARES - 2u);
    let row = min(u32(y), ROWS_OF_SHARES - 2u);
    let at = row * COLUMNS_OF_SHARES + column;
    let below = at + COLUMNS_OF_SHARES;
    let right = x - f32(column);
    let upper = mix(kept_share_at(at), kept_share_at(at + 1u), right);
    let lower = mix(kept_share_at(below), kept_share_at(below + 1u), right);
    return mix(upper, lower, y - f32(row));
}

fn kept_share_at(index: u32) -> f32 {
    return kept_shares[index / 4u][index % 4u];
}
