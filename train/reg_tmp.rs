use dpn_core::{io::asl, Sensor, random::Stream};
use dpn_train::{base::*, windows::*, levels::*, examples::*, features::*, label::*, regress::*, split::*};
fn main() {
    let dir = std::env::args().nth(1).unwrap();
    let b: Base = std::env::args().nth(2).unwrap().parse().unwrap();
    let t=std::time::Instant::now();
    let seqs = asl::discover(std::path::Path::new(&dir)).unwrap();
    let recs: Vec<_> = seqs.iter().map(|s| (s.name().to_owned(), s.imu().unwrap())).collect();
    println!("read {:?}", t.elapsed());
    let pick = |side| recs.iter().filter(|(n,_)| paper_side(n)==Some(side)).map(|(n,r)| (n.as_str(), r)).collect::<Vec<_>>();
    let sensor = Sensor::Accel;
    let train = WindowSet::cut(&pick(Side::Train), sensor, b, Scope::Window, Stretch::Whole).unwrap();
    let test = WindowSet::cut(&pick(Side::Test), sensor, b, Scope::Window, Stretch::Whole).unwrap();
    let lv = Levels::paper(sensor, LevelKind::Grid);
    let etr = Examples::draw(&train, &lv, &Stream::new(0).named("tr"));
    let ete = Examples::draw(&test, &lv, &Stream::new(0).named("te"));
    println!("{} {} {:?}", etr.len(), ete.len(), t.elapsed());
    let f = Features::new().unwrap();
    let regs = fit_all(&f, &etr, Label::Injected).unwrap();
    println!("fit {:?}", t.elapsed());
    let table = f.table(&ete.samples);
    println!("table {:?}", t.elapsed());
    let truth = ete.truth(Label::Injected);
    for r in regs { let p = r.predict(&table); let e: f64 = p.iter().zip(&truth).map(|(a,b)| (a-b).powi(2)).sum::<f64>()/p.len() as f64; println!("{} {:.5} {:?}", r.name(), e.sqrt(), t.elapsed()); }
}
