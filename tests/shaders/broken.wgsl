// What the tests by bits say of a number made here.
struct In {
    x: f32,
    y: f32,
    operation: u32,
    padding: u32,
}

struct Out {
    made: u32,
    nan: u32,
    infinite: u32,
    padding: u32,
}

fn made_of(x: f32, y: f32, operation: u32) -> f32 {
    switch operation {
        case 0u: {
            return x / y;
        }
        case 1u: {
            return x - y;
        }
        case 2u: {
            return x * y;
        }
        case 3u: {
            return sqrt(x);
        }
        case 4u: {
            return log(x);
        }
        default: {
            return exp(x);
        }
    }
}

fn run(row: u32) {
    let made = made_of(input[row].x, input[row].y, input[row].operation);
    output[row] = Out(bitcast<u32>(made), u32(is_nan(made)), u32(is_infinite(made)), 0u);
}
