//! stub
pub struct Entry { pub threshold: f32, pub alias: u32, pub probability: f32 }
pub struct AliasTable(Vec<Entry>);
impl AliasTable {
    pub fn new(w: &[f64]) -> AliasTable {
        let n = w.len(); let sum: f64 = w.iter().sum();
        let mut p: Vec<f64> = w.iter().map(|x| x * n as f64 / sum).collect();
        let mut e: Vec<Entry> = w.iter().enumerate().map(|(i, x)| Entry { threshold: 1.0, alias: i as u32, probability: (x / sum) as f32 }).collect();
        let (mut s, mut l): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| p[i] < 1.0);
        while let (Some(a), Some(&b)) = (s.pop(), l.last()) { e[a].threshold = p[a] as f32; e[a].alias = b as u32; p[b] -= 1.0 - p[a]; if p[b] < 1.0 { l.pop(); s.push(b); } }
        AliasTable(e)
    }
    pub fn entries(&self) -> &[Entry] { &self.0 }
}
pub struct SkyDistribution;
impl SkyDistribution {
    pub fn new(_: u32, _: u32, _: &[[f32; 3]]) -> SkyDistribution { SkyDistribution }
    pub fn integral(&self) -> f64 { 0.0 }
    pub fn words(&self) -> Vec<[u32; 4]> { Vec::new() }
}
