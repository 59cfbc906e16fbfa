use manylight::particles::trace_photons; use manylight::sampling::Pass; use manylight::scene::Scene;
use manylight_io::{load_scene, LoadOptions};
fn main(){ let a:Vec<String>=std::env::args().collect();
 let l=load_scene(std::path::Path::new(&a[1]),&LoadOptions::default()).unwrap();
 let t=std::time::Instant::now(); let s=Scene::build(l.desc,0).unwrap(); println!("build {:?}",t.elapsed());
 for pass in 0..4 { let t=std::time::Instant::now();
  let ph=trace_photons(&s,s.limits,a[2].parse().unwrap(),Pass{seed:0,index:pass});
  let near: Vec<_>=ph.iter().filter(|p| p.p.abs().max_element()<12.0).collect();
  let mut f:Vec<f32>=near.iter().map(|p|p.flux.luminance()).collect(); f.sort_by(|a,b|b.total_cmp(a));
  let tot:f64=f.iter().map(|x|*x as f64).sum(); let d1:f64=near.iter().filter(|p|p.depth==1).map(|p|p.flux.luminance() as f64).sum();
  let share=|n:usize| f.iter().take(n).map(|x|*x as f64).sum::<f64>()/tot;
  println!("pass {pass}: {} photons, {} near, flux near {tot:.4} direct {d1:.4} top1 {:.4} top10 {:.4} top100 {:.4} top1000 {:.3} median {:.3e} max {:.3e} time {:?}",ph.len(),near.len(),share(1),share(10),share(100),share(1000),f[f.len()/2],f[0],t.elapsed());
 }}
